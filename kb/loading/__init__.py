"""Loading into Prolog: a scene's facts, rules, and the words that questions may use."""
