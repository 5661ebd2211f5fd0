"""The optimal control problem: named costs and constraints over one instant, composed in a list."""
