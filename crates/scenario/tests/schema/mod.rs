//! The schema and the parser agree: of all scenarios of the project, of each field of each table, and of each bound.

mod bounds;
mod corpus;
mod files;
mod mutations;
mod validator;
