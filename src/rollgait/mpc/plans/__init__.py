"""Plans as references of the controller: looked up, followed with its own clock, held, joined."""
