"""What is odd about a model without faults: what never holds, is said twice, is not used."""
