"""What the extension computes, with numpy and the native module only: nothing here imports bpy."""
