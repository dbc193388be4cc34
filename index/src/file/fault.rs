//! Reading a mapped file that has been cut short: the fault becomes a flag instead of the end of
//! the process.
//!
//! A page of a mapping that lies beyond the end of its file raises SIGBUS in the thread that reads
//! it. `cp` over an index does that to everyone who has it mapped, because it truncates the file
//! first. The handler here puts zeros under the whole mapping, sets the mapping's flag and lets the
//! thread read on: every value is checked where it is used, so zeros do no harm, and whoever asks
//! [`Registered::has_faulted`] after the work throws its result away.
//!
//! Why this and not something else (`super::stamp` is the other half: it notices bytes that changed
//! without a fault):
//! - A private copy of every index costs its size again in memory or on the disk at every open. The
//!   service makes one of indexes that are small enough, which is the only way to go on answering;
//!   it cannot be the general answer.
//! - A lease (`F_SETLEASE`) has the kernel hold the writer back until the file has been copied
//!   away, but only for the file's owner, on few file systems, for 45 seconds, and the person's
//!   `cp` waits meanwhile.
//! - Reading by `pread` raises no fault, and costs a system call where a search now costs a cache
//!   miss.
//! - Jumping out of the handler skips destructors. Zeros cost nothing until a fault happens.

use std::io;
pub(crate) use system::Registered;

/// Has reading a mapped index that another program cuts short reported as [`crate::FileChanged`] by
/// [`crate::Index::check_unchanged`], instead of ending the process with SIGBUS.
///
/// Installs a handler of SIGBUS for the whole process, which is why no [`crate::Index`] does it by
/// itself: programs call this once, before they open an index. Faults outside of mapped indexes go
/// to the handler that was installed before. From then on, what an index answers may only be
/// believed where [`crate::Index::check_unchanged`] says so afterwards. Where there is no SIGBUS,
/// on systems other than Unix, this does nothing.
///
/// # Errors
/// When the system does not let a handler be installed.
pub fn guard_against_truncation() -> io::Result<()> {
    system::install()
}

#[cfg(unix)]
mod system {
    use std::io;
    use std::mem::MaybeUninit;
    use std::ptr;
    use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::SeqCst};
    use std::sync::{Mutex, OnceLock, PoisonError};

    use libc::{c_int, c_void, siginfo_t};

    /// Where a mapping lies, for the handler to find. Slots are used again, never freed: the
    /// handler may be reading any of them at any moment.
    #[derive(Debug)]
    struct Slot {
        /// The address of the mapping's first byte; 0 where the slot is free.
        start: AtomicUsize,
        /// In bytes.
        length: AtomicUsize,
        has_faulted: AtomicBool,
        next: OnceLock<&'static Slot>,
    }

    static FIRST: Slot = Slot::free();
    /// Slots without a mapping. Held while a slot is taken or given back, never by the handler.
    static FREE: Mutex<Vec<&'static Slot>> = Mutex::new(Vec::new());
    /// What handled SIGBUS before.
    static PREVIOUS: OnceLock<libc::sigaction> = OnceLock::new();

    impl Slot {
        const fn free() -> Self {
            Self {
                start: AtomicUsize::new(0),
                length: AtomicUsize::new(0),
                has_faulted: AtomicBool::new(false),
                next: OnceLock::new(),
            }
        }

        fn all() -> impl Iterator<Item = &'static Slot> {
            std::iter::successors(Some(&FIRST), |slot| slot.next.get().copied())
        }

        /// The mapping's start and length, where `address` lies in it.
        fn range_with(&self, address: usize) -> Option<(usize, usize)> {
            let start = self.start.load(SeqCst);
            let length = self.length.load(SeqCst);
            // A slot that is given to another mapping meanwhile shows the start of one and the
            // length of the other.
            let is_one_mapping = start != 0 && self.start.load(SeqCst) == start;
            (is_one_mapping && address.wrapping_sub(start) < length).then_some((start, length))
        }
    }

    /// A mapping that the handler knows, until this is dropped.
    #[derive(Debug)]
    pub(crate) struct Registered(&'static Slot);

    impl Registered {
        /// Makes a mapping known. It must be a read-only mapping of whole pages from its start on,
        /// which outlives this.
        pub(crate) fn new(mapping: &[u8]) -> Self {
            let mut free = FREE.lock().unwrap_or_else(PoisonError::into_inner);
            let slot = free.pop().unwrap_or_else(|| {
                let new: &'static Slot = Box::leak(Box::new(Slot::free()));
                // Only who holds the lock appends, so the last slot has no next one.
                if let Some(last) = Slot::all().last() {
                    let _ = last.next.set(new);
                }
                new
            });
            slot.has_faulted.store(false, SeqCst);
            slot.length.store(mapping.len(), SeqCst);
            slot.start.store(mapping.as_ptr() as usize, SeqCst);
            Self(slot)
        }

        /// Whether a page of the mapping could not be read. All of the mapping is zeros then.
        pub(crate) fn has_faulted(&self) -> bool {
            self.0.has_faulted.load(SeqCst)
        }
    }

    impl Drop for Registered {
        fn drop(&mut self) {
            self.0.start.store(0, SeqCst);
            FREE.lock().unwrap_or_else(PoisonError::into_inner).push(self.0);
        }
    }

    /// Installs the handler, the first time.
    pub(super) fn install() -> io::Result<()> {
        static INSTALLED: Mutex<bool> = Mutex::new(false);
        let mut is_installed = INSTALLED.lock().unwrap_or_else(PoisonError::into_inner);
        if *is_installed {
            return Ok(());
        }
        let mut previous = MaybeUninit::<libc::sigaction>::zeroed();
        // SAFETY: no action is given, so none is changed, and `previous` is room for one.
        if unsafe { libc::sigaction(libc::SIGBUS, ptr::null(), previous.as_mut_ptr()) } != 0 {
            return Err(io::Error::last_os_error());
        }
        // Before the handler is there, which passes on to it.
        // SAFETY: the call has filled it in; and zeros are one as well.
        PREVIOUS.get_or_init(|| unsafe { previous.assume_init() });
        let mut action = MaybeUninit::<libc::sigaction>::zeroed();
        // SAFETY: zeros are an action (the default one, with no flag and an empty mask) of which
        // three fields are set.
        let action = unsafe {
            let action = action.assume_init_mut();
            action.sa_sigaction = on_fault as *const () as usize;
            // On the stack for signals, where the thread has one: as std's own handler, which this
            // one passes on to.
            action.sa_flags = libc::SA_SIGINFO | libc::SA_ONSTACK;
            libc::sigemptyset(&mut action.sa_mask);
            action
        };
        // SAFETY: the action is whole, and `on_fault` does only what a signal handler may: it reads
        // and writes atomics that are never freed, and makes system calls.
        if unsafe { libc::sigaction(libc::SIGBUS, action, ptr::null_mut()) } != 0 {
            return Err(io::Error::last_os_error());
        }
        *is_installed = true;
        Ok(())
    }

    extern "C" fn on_fault(signal: c_int, info: *mut siginfo_t, context: *mut c_void) {
        // SAFETY: SA_SIGINFO has the kernel pass one that is filled in. One that a process sent has
        // another number in the address's place, which the code tells apart.
        let (code, address) = unsafe { ((*info).si_code, (*info).si_addr() as usize) };
        if code == libc::BUS_ADRERR && put_zeros_around(address) {
            // The instruction is tried again, and finds them.
            return;
        }
        pass_on(signal, info, context);
    }

    /// Whether the address lies in a known mapping, which is all zeros from now on.
    fn put_zeros_around(address: usize) -> bool {
        let Some((slot, (start, length))) =
            Slot::all().find_map(|slot| slot.range_with(address).map(|range| (slot, range)))
        else {
            return false;
        };
        // Before there is a zero to be read.
        slot.has_faulted.store(true, SeqCst);
        // All of the mapping, not the page alone: a file cut to nothing has millions of them, and a
        // process may hold only so many mappings. A call that succeeds leaves `errno` as it was.
        // SAFETY: these are the pages of a mapping that is read-only, is no one's but `Bytes`', and
        // lives on while the thread that faulted borrows its bytes: new read-only pages in their
        // place are what `Bytes` unmaps in the end. Their bytes change under whoever reads them, as
        // they do where the file is overwritten: see `Bytes::map`.
        let zeros = unsafe {
            let flags = libc::MAP_PRIVATE | libc::MAP_ANON | libc::MAP_FIXED;
            libc::mmap(start as *mut c_void, length, libc::PROT_READ, flags, -1, 0)
        };
        zeros != libc::MAP_FAILED
    }

    /// Does what would have been done without this handler.
    fn pass_on(signal: c_int, info: *mut siginfo_t, context: *mut c_void) {
        let previous = PREVIOUS.get().map(|action| (action.sa_sigaction, action.sa_flags));
        match previous {
            Some((handler, flags)) if handler != libc::SIG_DFL && handler != libc::SIG_IGN => {
                if flags & libc::SA_SIGINFO != 0 {
                    // SAFETY: what is neither of the two numbers is a handler, of this form where
                    // the flag is set.
                    let handler = unsafe {
                        std::mem::transmute::<usize, extern "C" fn(c_int, *mut siginfo_t, *mut c_void)>(
                            handler,
                        )
                    };
                    handler(signal, info, context);
                } else {
                    // SAFETY: as above, of this form where it is not.
                    let handler = unsafe { std::mem::transmute::<usize, extern "C" fn(c_int)>(handler) };
                    handler(signal);
                }
            }
            // A fault cannot be ignored: the instruction would fault for ever.
            _ => {
                // SAFETY: zeros are the default action; both calls are allowed in a handler. The
                // signal waits until this handler returns, and then ends the process.
                unsafe {
                    let action = MaybeUninit::<libc::sigaction>::zeroed().assume_init();
                    libc::sigaction(signal, &action, ptr::null_mut());
                    libc::raise(signal);
                }
            }
        }
    }
}

#[cfg(not(unix))]
mod system {
    use std::io;

    /// Other systems do not let a mapped file be cut short.
    #[derive(Debug)]
    pub(crate) struct Registered;

    impl Registered {
        pub(crate) fn new(_: &[u8]) -> Self {
            Self
        }

        pub(crate) fn has_faulted(&self) -> bool {
            false
        }
    }

    pub(super) fn install() -> io::Result<()> {
        Ok(())
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use crate::FileChanged;
    use crate::file::bytes::Bytes;
    use std::fs::{self, File};
    use std::os::unix::process::ExitStatusExt as _;
    use std::path::Path;
    use std::process::{Command, ExitStatus};

    const PAGES: usize = 64 * 4096;

    fn ones(folder: &Path) -> std::path::PathBuf {
        let path = folder.join("ones");
        fs::write(&path, vec![1; PAGES]).unwrap();
        path
    }

    fn cut(path: &Path, length: u64) {
        File::options().write(true).open(path).unwrap().set_len(length).unwrap();
    }

    #[test]
    fn a_mapping_cut_short_reads_as_zeros_on_every_thread_and_says_so() {
        guard_against_truncation().unwrap();
        let folders = [(); 2].map(|()| tempfile::tempdir().unwrap());
        let [path, other] = folders.each_ref().map(|folder| ones(folder.path()));
        let (cut_short, bystander) = (Bytes::map(&path).unwrap(), Bytes::map(&other).unwrap());
        assert_eq!(cut_short.check_unchanged(), Ok(()));
        cut(&path, 4096);
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| assert_eq!(cut_short.iter().rev().find(|&&byte| byte == 1), None));
            }
        });
        // Whole again, but too late.
        fs::write(&path, vec![1; PAGES]).unwrap();
        assert_eq!(cut_short.check_unchanged(), Err(FileChanged));
        assert!(bystander.iter().all(|&byte| byte == 1));
        assert_eq!(bystander.check_unchanged(), Ok(()));
    }

    #[test]
    fn slots_are_used_again_and_none_remembers_the_fault_before() {
        guard_against_truncation().unwrap();
        let folder = tempfile::tempdir().unwrap();
        for _ in 0..50 {
            let path = ones(folder.path());
            let bytes = Bytes::map(&path).unwrap();
            assert_eq!((bytes[PAGES - 1], bytes.check_unchanged()), (1, Ok(())));
            cut(&path, 0);
            assert_eq!((bytes[PAGES - 1], bytes.check_unchanged()), (0, Err(FileChanged)));
        }
    }

    /// Runs this test again in a process of its own, which may end as it likes.
    fn alone(test: &str) -> Option<ExitStatus> {
        const INSIDE: &str = "GRASP_FAULT_TEST";
        if std::env::var_os(INSIDE).is_some() {
            return None;
        }
        let name = format!("file::fault::tests::{test}");
        let mut command = Command::new(std::env::current_exe().unwrap());
        Some(command.args(["--exact", &name]).env(INSIDE, "1").output().unwrap().status)
    }

    /// Reads a mapping, that no index made, beyond the end of its file.
    fn fault_elsewhere() {
        let folder = tempfile::tempdir().unwrap();
        let path = ones(folder.path());
        let file = File::open(&path).unwrap();
        // SAFETY: the mapping is read as bytes; that reading it faults is what this process is for.
        let map = unsafe { memmap2::Mmap::map(&file).unwrap() };
        cut(&path, 0);
        assert_eq!(std::hint::black_box(&map)[PAGES - 1], 0, "no fault");
    }

    #[test]
    fn faults_elsewhere_go_to_the_handler_before() {
        extern "C" fn before(_: libc::c_int) {
            // SAFETY: ends the process at once, as a handler may.
            unsafe { libc::_exit(42) }
        }
        if let Some(status) = alone("faults_elsewhere_go_to_the_handler_before") {
            assert_eq!(status.code(), Some(42));
            return;
        }
        // SAFETY: `before` does what a handler may.
        unsafe { libc::signal(libc::SIGBUS, before as *const () as usize) };
        guard_against_truncation().unwrap();
        fault_elsewhere();
    }

    #[test]
    fn faults_elsewhere_end_the_process_where_nothing_else_was_to_be_done() {
        if let Some(status) = alone("faults_elsewhere_end_the_process_where_nothing_else_was_to_be_done") {
            assert_eq!(status.signal(), Some(libc::SIGBUS));
            return;
        }
        guard_against_truncation().unwrap();
        guard_against_truncation().unwrap();
        fault_elsewhere();
    }

    #[test]
    fn a_signal_that_a_process_sends_is_no_fault() {
        if let Some(status) = alone("a_signal_that_a_process_sends_is_no_fault") {
            assert_eq!(status.signal(), Some(libc::SIGBUS));
            return;
        }
        // std's own handler ignores one.
        // SAFETY: this process does nothing else with signals.
        unsafe { libc::signal(libc::SIGBUS, libc::SIG_DFL) };
        guard_against_truncation().unwrap();
        let folder = tempfile::tempdir().unwrap();
        let _mapped = Bytes::map(&ones(folder.path())).unwrap();
        // SAFETY: the signal ends this process, which is there for that.
        unsafe { libc::raise(libc::SIGBUS) };
    }
}
