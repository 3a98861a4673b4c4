"""Many runs: designs over the paths of a spec, computed once each and kept in a cache."""
