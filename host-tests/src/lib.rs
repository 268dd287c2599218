//! What stands around `meerkat-mwd` on a desk: traces in, results and scores out.
