"""Pictures as they come from cameras, and which of their pixels are robot."""
