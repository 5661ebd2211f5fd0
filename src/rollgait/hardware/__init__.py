"""A robot driven over a transport: messages in, a controller between, joint commands out."""
