"""What is controlled, as controller and simulation both see it: states, controls, disturbances, falls.

It stands under both of them, so that neither needs to know the other.
"""
