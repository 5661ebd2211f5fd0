"""Controls of the draft: each shows keys of it, and what a person sets is a change of it."""
