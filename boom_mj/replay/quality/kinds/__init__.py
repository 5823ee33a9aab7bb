"""Kinds of findings, one file each; being here is being registered."""
