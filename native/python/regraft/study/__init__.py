"""Studies: how trees age over a shot, what that costs, and what can be left out."""
