"""Operators, one feature a module. Each is complete by its properties alone; panels only fill them in."""
