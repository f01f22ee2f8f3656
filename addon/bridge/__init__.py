"""The only code that moves data between Blender and numpy."""
