"""The peers: what else would run this capture, each in the best way its users have, all on the one exact model.

Nothing here imports the product or its array library, so that the two sides share no line of code but the measuring
(`benchmarks.accuracy`).
"""
