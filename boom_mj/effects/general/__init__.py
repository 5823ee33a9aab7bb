"""Effects of any MJCF machine, one file each; a file here is registered by being here."""
