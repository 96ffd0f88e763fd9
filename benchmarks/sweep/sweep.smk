# The cost variants against each other, where the build has `planegraph sweep`.
SWEEP_EXPERIMENT = os.path.join(ROOT, config["sweep"]["experiment"])
