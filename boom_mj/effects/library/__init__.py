"""One file per effect; presence is registration."""
