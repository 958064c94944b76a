"""The step loop of compiled methods: Newton's iteration, linear algebra, step size control, and switches."""
