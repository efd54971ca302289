"""Pictures of a run and of single estimates; they need the extra `plots`."""
