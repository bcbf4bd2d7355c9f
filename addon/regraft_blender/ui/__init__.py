"""Settings, panels and operators."""
