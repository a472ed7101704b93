"""How Prolog is reached: started, asked on threads or in a process of its own, and answered."""
