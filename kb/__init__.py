"""Facts and models into verdicts and proofs, by an embedded SWI-Prolog."""
