//! Certificates as rustls judges them, and the files that they are in.

use std::fs;
use std::os::unix::fs::PermissionsExt;

use rustls_pki_types::pem::PemObject;
use rustls_pki_types::{CertificateDer, ServerName, UnixTime};
use webpki::{EndEntityCert, KeyUsage, anchor_from_trusted_cert};

use super::*;

fn now() -> SystemTime {
    // A Tuesday in 2027.
    UNIX_EPOCH + Duration::from_secs(1_800_000_000)
}

fn authority() -> Authority {
    Authority::new(&"lab".parse().unwrap(), Lifetime::days(3650), now()).unwrap()
}

fn server(names: &[&str]) -> Role {
    Role::Server(names.iter().map(|name| name.parse().unwrap()).collect())
}

/// Whether rustls takes this certificate, so many seconds later.
fn is_taken(authority: &str, issued: &Issued, usage: KeyUsage, later_s: i64) -> bool {
    let certificate = CertificateDer::from_pem_slice(issued.certificate.as_bytes()).unwrap();
    let root = CertificateDer::from_pem_slice(authority.as_bytes()).unwrap();
    let anchors = [anchor_from_trusted_cert(&root).unwrap()];
    let since = now().duration_since(UNIX_EPOCH).unwrap().as_secs().checked_add_signed(later_s).unwrap();
    let time = UnixTime::since_unix_epoch(Duration::from_secs(since));
    let algorithms = [webpki::ring::ECDSA_P256_SHA256];
    let leaf = EndEntityCert::try_from(&certificate).unwrap();
    leaf.verify_for_usage(&algorithms, &anchors, &[], time, usage, None, None).is_ok()
}

fn is_for(issued: &Issued, name: &str) -> bool {
    let certificate = CertificateDer::from_pem_slice(issued.certificate.as_bytes()).unwrap();
    let leaf = EndEntityCert::try_from(&certificate).unwrap();
    leaf.verify_is_valid_for_subject_name(&ServerName::try_from(name).unwrap()).is_ok()
}

#[test]
fn a_server_is_known_by_its_names_and_no_others() {
    let authority = authority();
    let names = server(&["robots.lab", "*.cluster.lab", "10.0.0.7", "::1"]);
    let issued = authority.issue(&names, Lifetime::days(365), now()).unwrap();
    assert!(is_taken(authority.certificate(), &issued, KeyUsage::server_auth(), 0));
    assert!(!is_taken(authority.certificate(), &issued, KeyUsage::client_auth(), 0));
    for name in ["robots.lab", "ROBOTS.lab", "n1.cluster.lab", "10.0.0.7", "::1"] {
        assert!(is_for(&issued, name), "{name}");
    }
    for name in ["lab", "other.lab", "a.b.cluster.lab", "10.0.0.8", "::2"] {
        assert!(!is_for(&issued, name), "{name}");
    }
}

#[test]
fn a_client_is_no_server_and_another_authority_knows_neither() {
    let (authority, other) = (authority(), authority());
    let issued = authority.issue(&Role::Client("alice".parse().unwrap()), Lifetime::days(30), now()).unwrap();
    assert!(is_taken(authority.certificate(), &issued, KeyUsage::client_auth(), 0));
    assert!(!is_taken(authority.certificate(), &issued, KeyUsage::server_auth(), 0));
    assert!(!is_taken(other.certificate(), &issued, KeyUsage::client_auth(), 0));
}

#[test]
fn a_certificate_is_valid_from_the_day_before_until_its_end() {
    let authority = authority();
    let issued = authority.issue(&server(&["robots.lab"]), Lifetime::days(30), now()).unwrap();
    let valid = |later_s| is_taken(authority.certificate(), &issued, KeyUsage::server_auth(), later_s);
    let day = 24 * 60 * 60;
    assert_eq!([-day - 1, -day, 0, 30 * day, 30 * day + 1].map(valid), [false, true, true, true, false]);
    assert_eq!(issued.ends_at, now() + Lifetime::days(30).duration());
    let error =
        authority.issue(&server(&["robots.lab"]), Lifetime::days(3651), now()).map(|_| ()).unwrap_err();
    assert!(matches!(error, CertificateError::Outlives { .. }), "{error}");
    let error = authority.issue(&server(&[]), Lifetime::days(1), now()).map(|_| ()).unwrap_err();
    assert!(matches!(error, CertificateError::NoName), "{error}");
}

#[test]
fn an_authority_that_is_loaded_issues_as_before() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path().join("certificates");
    let authority = authority();
    let paths = authority.write(&folder).unwrap();
    let loaded = Authority::load(&folder).unwrap();
    assert_eq!((loaded.certificate(), loaded.ends_at()), (authority.certificate(), authority.ends_at()));
    let role = server(&["10.0.0.7"]);
    let issued = loaded.issue(&role, Lifetime::days(30), now()).unwrap();
    assert!(is_taken(authority.certificate(), &issued, KeyUsage::server_auth(), 0));
    let written = issued.write(&folder, &role).unwrap();
    let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
    assert_eq!([&paths.key, &written.key].map(|path| mode(path)), [0o600; 2]);
    assert_eq!([&paths.certificate, &written.certificate].map(|path| mode(path)), [0o644; 2]);
    assert_eq!(written.key, folder.join("10.0.0.7-key.pem"));
    assert_eq!(fs::read_to_string(&written.key).unwrap(), issued.key);
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 4);
}

#[test]
fn nothing_is_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    let authority = authority();
    authority.write(folder.path()).unwrap();
    let error = self::authority().write(folder.path()).unwrap_err();
    assert!(
        error
            .to_string()
            .ends_with("ca-key.pem: already exists; move it away, or choose another folder or name"),
        "{error}"
    );
    assert_eq!(Authority::load(folder.path()).unwrap().certificate(), authority.certificate());
    let role = Role::Client("ca".parse().unwrap());
    let issued = authority.issue(&role, Lifetime::days(1), now()).unwrap();
    assert!(matches!(issued.write(folder.path(), &role), Err(CertificateError::Reserved)));
    let role = server(&["a.lab"]);
    let issued = authority.issue(&role, Lifetime::days(1), now()).unwrap();
    fs::write(folder.path().join("a.lab.pem"), "mine").unwrap();
    assert!(matches!(issued.write(folder.path(), &role), Err(CertificateError::Exists { .. })));
    assert!(!folder.path().join("a.lab-key.pem").exists(), "no half of a pair");
}

#[test]
fn an_authority_that_is_none_is_refused_with_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let said = || Authority::load(folder.path()).unwrap_err().to_string();
    assert!(said().contains("ca-key.pem: No such file"), "{}", said());
    let authority = authority();
    authority.write(folder.path()).unwrap();
    let good = fs::read_to_string(path("ca.pem")).unwrap();
    let begins = |name: &str, problem: &str| {
        let expected = format!("{}: {problem}", path(name).display());
        assert!(said().starts_with(&expected), "{}", said());
    };
    fs::write(path("ca.pem"), "no certificate").unwrap();
    begins("ca.pem", "is not a certificate in PEM");
    fs::write(path("ca.pem"), good.replace("CERTIFICATE", "PUBLIC KEY")).unwrap();
    begins("ca.pem", "is not a certificate in PEM");
    fs::write(path("ca.pem"), self::authority().certificate()).unwrap();
    begins("ca.pem", "is not the certificate of this key");
    let leaf = authority.issue(&server(&["a.lab"]), Lifetime::days(1), now()).unwrap();
    fs::write(path("ca.pem"), &leaf.certificate).unwrap();
    begins("ca.pem", "is not the certificate of an authority");
    fs::write(path("ca.pem"), &good).unwrap();
    Authority::load(folder.path()).unwrap();
    fs::set_permissions(path("ca-key.pem"), fs::Permissions::from_mode(0o640)).unwrap();
    begins("ca-key.pem", "others can read or write it (mode 0640); fix that with: chmod 600 ");
    fs::set_permissions(path("ca-key.pem"), fs::Permissions::from_mode(0o600)).unwrap();
    fs::write(path("ca-key.pem"), "no key").unwrap();
    begins("ca-key.pem", "is not a private key in PEM");
}

#[test]
fn a_key_is_not_shown_by_accident() {
    let authority = authority();
    let key = authority.issuer.key().serialize_pem();
    let shown = format!("{authority:?}");
    let secret: Vec<_> = key.lines().filter(|line| !line.starts_with("--")).collect();
    assert!(secret.iter().all(|line| !shown.contains(line)) && shown.contains("elided"), "{shown}");
}
