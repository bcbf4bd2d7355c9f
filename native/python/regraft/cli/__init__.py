"""The `regraft` command."""
