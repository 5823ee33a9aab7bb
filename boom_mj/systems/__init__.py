"""What a diagnosis knows of a machine: a system says what its sensors would log under a hypothesis."""
