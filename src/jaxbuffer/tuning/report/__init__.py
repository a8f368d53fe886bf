"""What is told of a tuning: message, limits in the way, the tuned design."""
