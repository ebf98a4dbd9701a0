//! Whatever the scenario, what is measured is within the bounds.
