"""The physics: rotations, the rigid body, the feet. CasADi expressions, no data."""
