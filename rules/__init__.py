"""The vocabulary and the models: data only, as Prolog files that a user may read and change."""
