"""A motion being designed: the draft, its history, its handles in the scene, and what came of it."""
