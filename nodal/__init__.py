"""The roof: the `nodal` command, the bench file, the demo and its report. The only room that knows all the others."""
