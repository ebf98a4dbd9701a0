//! Work that takes long, on threads of its own.

use tonic::Status;

/// Does work that takes long, while other calls go on.
///
/// # Errors
/// `INTERNAL` if the work panics.
pub(crate) async fn blocking<T: Send + 'static>(
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T, Status> {
    tokio::task::spawn_blocking(work).await.map_err(|error| Status::internal(error.to_string()))
}
