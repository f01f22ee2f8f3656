"""Settings that are saved in the file, one feature a module."""
