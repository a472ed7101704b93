"""How far things are from each other, and what that makes of them: what carries what."""
