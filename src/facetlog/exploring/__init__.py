"""The next view: what is undecided, what each view promises to settle, and which is taken."""
