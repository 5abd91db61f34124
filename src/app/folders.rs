//! Where settings and what is remembered are kept: the folders of the XDG base directory specification, or Windows'
//! own.

use std::ffi::OsString;
use std::path::PathBuf;

const NAME: &str = "raybomb";

/// The settings file, there or not; `None` where a user has no folder of their own. `env` looks up environment
/// variables.
#[must_use]
pub fn config_file(env: impl Fn(&str) -> Option<OsString>) -> Option<PathBuf> {
    let base = base(&env, "XDG_CONFIG_HOME", "APPDATA", &[".config"])?;
    Some(base.join(NAME).join("config.toml"))
}

/// The folder for what is remembered from one start to the next.
#[must_use]
pub fn state_folder(env: impl Fn(&str) -> Option<OsString>) -> Option<PathBuf> {
    let base = base(&env, "XDG_STATE_HOME", "LOCALAPPDATA", &[".local", "state"])?;
    Some(base.join(NAME))
}

fn base(
    env: &impl Fn(&str) -> Option<OsString>,
    xdg: &str,
    windows: &str,
    in_home: &[&str],
) -> Option<PathBuf> {
    // A path that is not absolute is to be ignored, says the specification.
    let folder = |name: &str| env(name).map(PathBuf::from).filter(|p| p.is_absolute());
    let system = || folder(windows).filter(|_| cfg!(windows));
    let home = || {
        Some(
            in_home
                .iter()
                .fold(folder("HOME")?, |path, part| path.join(part)),
        )
    };
    folder(xdg).or_else(system).or_else(home)
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    fn paths(vars: &[(&str, &str)]) -> [Option<String>; 2] {
        let env = |name: &str| {
            let var = vars.iter().find(|(n, _)| *n == name);
            var.map(|(_, value)| value.into())
        };
        [config_file(env), state_folder(env)].map(|p| p.map(|p| p.display().to_string()))
    }

    #[test]
    fn folders_are_those_of_the_xdg_specification() {
        let some = |config: &str, state: &str| [Some(config.to_owned()), Some(state.to_owned())];
        let home = ("HOME", "/h");
        let in_home = some("/h/.config/raybomb/config.toml", "/h/.local/state/raybomb");
        assert_eq!(paths(&[home]), in_home);
        for relative in ["", "here"] {
            let vars = [
                home,
                ("XDG_CONFIG_HOME", relative),
                ("XDG_STATE_HOME", relative),
            ];
            assert_eq!(paths(&vars), in_home);
        }
        let vars = [("XDG_CONFIG_HOME", "/c"), ("XDG_STATE_HOME", "/s")];
        assert_eq!(paths(&vars), some("/c/raybomb/config.toml", "/s/raybomb"));
        assert_eq!(paths(&[]), [None, None]);
    }
}
