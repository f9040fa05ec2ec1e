"""Long work: batches of glides, cut into chunks that survive whoever computes them. Knows no HTTP."""
