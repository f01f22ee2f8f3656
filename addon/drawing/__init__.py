"""What is drawn over the 3D view: marks, the picture of landmarks, ghosts of arcs."""
