"""What a controller can control."""
