"""`nodal new`: the folder of a bench to begin with.

`writing` puts it together, `true_bench` draws what a simulated one really is; the texts are those of the `.toml` files here.
"""
