"""The embedded SWI-Prolog: its start, requests on any thread, answers."""
