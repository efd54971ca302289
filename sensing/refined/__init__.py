"""The default method: a tube in space, fitted to the silhouettes' edges in all cameras at once."""
