//! The laboratory: jobs, budgets, verification, measurement. The only place that writes rows.
