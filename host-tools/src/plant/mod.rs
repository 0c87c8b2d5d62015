//! The simulated robot: a forward simulation that shares no formula with model-core.
