//! Work that takes a while, beside the threads on which services run.

use tonic::Status;

/// Work that takes a while, in which others must not wait.
pub(crate) async fn blocking<T: Send + 'static>(
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T, Status> {
    tokio::task::spawn_blocking(work).await.map_err(|error| Status::internal(error.to_string()))
}
