"""Camera heads: codecs of their commands and answers, and their drivers."""
