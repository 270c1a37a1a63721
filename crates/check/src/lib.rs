//! Is a recorded log what the estimators take it for?
