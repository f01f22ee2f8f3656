"""The subcommands of ``blender --command lissom``: each has SUMMARY, configure(parser) and run(arguments)."""
