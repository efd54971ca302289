"""Cameras that are files: a video, a folder of pictures, a recording. They give frames as a camera does, then end.

`opening` makes the cameras, `playback` keeps them in step; `avi`, `folder` and `recording` each read one kind of file.
"""
