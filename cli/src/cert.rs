//! `baudbot cert`: a certificate authority of one's own, and certificates for servers and clients.

use crate::args::CertCommand;

#[cfg(feature = "certificates")]
pub(crate) use with::cert;

#[cfg(not(feature = "certificates"))]
pub(crate) fn cert(_: &CertCommand) -> anyhow::Result<()> {
    Err(crate::error::Refused::error(
        "cert: this program was built without certificates; cargo build --release --features certificates",
    ))
}

#[cfg(feature = "certificates")]
mod with {
    use std::path::Path;
    use std::time::SystemTime;

    use baudbot_access::certificates::{Authority, BadHost, CertificateError, Paths, Role};
    use baudbot_access::{GrantName, Lifetime, PrivateError, date};

    use super::CertCommand;
    use crate::args::{AuthorityArgs, ClientCertificateArgs, ServerCertificateArgs};
    use crate::error::Refused;
    use crate::text;

    pub(crate) fn cert(command: &CertCommand) -> anyhow::Result<()> {
        let now = SystemTime::now();
        let (paths, end) = match command {
            CertCommand::Ca(AuthorityArgs { folder, name, expires }) => {
                authority(folder, name, *expires, now)
            }
            CertCommand::Server(ServerCertificateArgs { folder, names, expires }) => {
                let hosts = names.iter().map(|name| name.parse()).collect::<Result<_, BadHost>>();
                let hosts = hosts.map_err(|error| Refused::error(error.to_string()))?;
                issue(folder, &Role::Server(hosts), *expires, now)
            }
            CertCommand::Client(ClientCertificateArgs { folder, name, expires }) => {
                issue(folder, &Role::Client(name.clone()), *expires, now)
            }
        }
        .map_err(refused)?;
        let (certificate, key) = (paths.certificate.display(), paths.key.display());
        text::print(&format!("{certificate}, valid until {}\n{key}, which is secret\n", date::print(end)))
    }

    type Made = Result<(Paths, SystemTime), CertificateError>;

    fn authority(folder: &Path, name: &GrantName, validity: Lifetime, now: SystemTime) -> Made {
        let authority = Authority::new(name, validity, now)?;
        Ok((authority.write(folder)?, authority.ends_at()))
    }

    fn issue(folder: &Path, role: &Role, validity: Lifetime, now: SystemTime) -> Made {
        let issued = Authority::load(folder)?.issue(role, validity, now)?;
        Ok((issued.write(folder, role)?, issued.ends_at))
    }

    /// A request or a file has to be changed, a system's refusal is a failure.
    fn refused(error: CertificateError) -> anyhow::Error {
        match error {
            CertificateError::File(PrivateError::Io { .. } | PrivateError::Locked { .. })
            | CertificateError::Make(_) => error.into(),
            CertificateError::File(_)
            | CertificateError::Exists { .. }
            | CertificateError::Key { .. }
            | CertificateError::Certificate { .. }
            | CertificateError::Outlives { .. }
            | CertificateError::NoName
            | CertificateError::Reserved => Refused::error(error.to_string()),
        }
    }
}
