"""Panels in the sidebar of the 3D View, one feature a module."""
