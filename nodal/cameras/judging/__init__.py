"""How good cameras' pictures are for sensing, in figures and in words.

`taking` gets frames; `sharpness`, `light` and `steadiness` measure one thing each, `measuring` all of them for a camera, `timing`
for cameras together; `verdicts` says what the figures mean and `suggestions` what to set; `annotating` draws it.
"""
