"""A study: many captures at once, one in each lane of a vector register, against the loop.

The product does not use it: it gains too little for what it costs (docs/numerics.md, *Captures in the lanes of a vector
register*).
"""
