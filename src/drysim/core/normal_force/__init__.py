"""Normal force: Coulomb's friction where what presses the surfaces together varies."""
