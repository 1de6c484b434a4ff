//! `-- calls`: what one call costs, through the C interface, on one thread.
//!
//! Each call is made through a pointer to the exported function, which no compiler sees through: *linked* is the library in this program, *shared* is
//! `libopenrt.so` as a C program finds it, whose thread-local storage costs a little more. A round makes [`CALLS`] calls; the best of many rounds counts, in processor time of the thread.
//!
//! `goal` is what is promised in nanoseconds for the linked library on a current desktop processor; a slower one is told by the line *empty*, a call of a function that does nothing.

use crate::measure::thread_seconds;
use crate::options::Options;
use openrt::capi;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::hint::black_box;

const CALLS: usize = 1500;
const ROUNDS: usize = 400;
const QUICK_ROUNDS: usize = 100;

type Nothing = unsafe extern "C" fn();
type Three = unsafe extern "C" fn(f32, f32, f32);
type Pointer = unsafe extern "C" fn(*const f32);
type Number = unsafe extern "C" fn(u32);
type Get = unsafe extern "C" fn() -> u32;

/// The functions that are measured, or needed to.
struct Functions {
    init: unsafe extern "C" fn(*mut c_int, *mut *mut c_char),
    exit: Nothing,
    new_object: unsafe extern "C" fn(u32, u32),
    end_object: Nothing,
    begin: Number,
    end: Nothing,
    vertex3f: Three,
    vertex3fv: Pointer,
    normal3f: Three,
    color3f: Three,
    push: Nothing,
    pop: Nothing,
    translate: Three,
    instantiate: Number,
    clear: Nothing,
    get_error: Get,
}

impl Functions {
    fn linked() -> Self {
        Self {
            init: capi::rtInit,
            exit: capi::rtExit,
            new_object: capi::rtNewObject,
            end_object: capi::rtEndObject,
            begin: capi::rtBegin,
            end: capi::rtEnd,
            vertex3f: capi::rtVertex3f,
            vertex3fv: capi::rtVertex3fv,
            normal3f: capi::rtNormal3f,
            color3f: capi::rtColor3f,
            push: capi::rtPushMatrix,
            pop: capi::rtPopMatrix,
            translate: capi::rtTranslatef,
            instantiate: capi::rtInstantiateObject,
            clear: capi::rtClearInstances,
            get_error: capi::rtGetError,
        }
    }

    /// Those of the shared library of the same profile, if it was built.
    fn shared() -> Option<Self> {
        let program = std::env::current_exe().ok()?;
        let path = program.parent()?.parent()?.join("libopenrt.so");
        let path = CString::new(path.to_str()?).ok()?;
        // SAFETY: a string; the library has no initialisers of its own.
        let library = unsafe { libc::dlopen(path.as_ptr(), libc::RTLD_NOW | libc::RTLD_LOCAL) };
        if library.is_null() {
            return None;
        }
        /// # Safety
        /// `T` is the type of the function called `name`.
        unsafe fn find<T: Copy>(library: *mut c_void, name: &CStr) -> Option<T> {
            // SAFETY: a handle of dlopen, and a string.
            let symbol = unsafe { libc::dlsym(library, name.as_ptr()) };
            assert!(size_of::<T>() == size_of_val(&symbol));
            // SAFETY: a function pointer, of this type by contract.
            (!symbol.is_null()).then(|| unsafe { std::mem::transmute_copy(&symbol) })
        }
        // SAFETY: the types are those of the header.
        unsafe {
            Some(Self {
                init: find(library, c"rtInit")?,
                exit: find(library, c"rtExit")?,
                new_object: find(library, c"rtNewObject")?,
                end_object: find(library, c"rtEndObject")?,
                begin: find(library, c"rtBegin")?,
                end: find(library, c"rtEnd")?,
                vertex3f: find(library, c"rtVertex3f")?,
                vertex3fv: find(library, c"rtVertex3fv")?,
                normal3f: find(library, c"rtNormal3f")?,
                color3f: find(library, c"rtColor3f")?,
                push: find(library, c"rtPushMatrix")?,
                pop: find(library, c"rtPopMatrix")?,
                translate: find(library, c"rtTranslatef")?,
                instantiate: find(library, c"rtInstantiateObject")?,
                clear: find(library, c"rtClearInstances")?,
                get_error: find(library, c"rtGetError")?,
            })
        }
    }
}

extern "C" fn empty(x: f32, _: f32, _: f32) {
    black_box(x);
}

/// What is measured, and what is promised, in nanoseconds.
const ROWS: [(&str, Option<f64>); 11] = [
    ("empty", None),
    ("rtVertex3f, triangles", Some(15.0)),
    ("rtVertex3fv, triangles", Some(15.0)),
    ("rtVertex3f, strip", None),
    ("rtNormal3f + rtVertex3f", None),
    ("rtColor3f + rtVertex3f", None),
    ("rtBegin + rtEnd", None),
    ("rtPushMatrix + rtTranslatef + rtPopMatrix", Some(60.0)),
    ("rtInstantiateObject", Some(100.0)),
    ("rtPushMatrix … rtInstantiateObject … rtPopMatrix", None),
    ("rtGetError", Some(20.0)),
];

/// Nanoseconds of each of [`ROWS`].
fn measure(f: &Functions, rounds: usize) -> [f64; ROWS.len()] {
    let mut best = [f64::INFINITY; ROWS.len()];
    let mut one = |row: usize, prepare: &mut dyn FnMut(), call: &mut dyn FnMut(), after: &mut dyn FnMut()| {
        for _ in 0..rounds {
            prepare();
            let begin = thread_seconds();
            call();
            best[row] = best[row].min((thread_seconds() - begin) * 1e9 / CALLS as f64);
            after();
        }
    };
    // SAFETY: calls of the C interface as its manual allows them.
    unsafe {
        (f.init)(std::ptr::null_mut(), std::ptr::null_mut());
        (f.new_object)(1, capi::RT_COMPILE);
        (f.end_object)();
        let mut nothing = || {};
        let empty = black_box(empty as Three);
        one(0, &mut nothing, &mut || (0..CALLS).for_each(|i| empty(i as f32, 1.0, 2.0)), &mut || {});
        let (vertex3f, vertex3fv) = (black_box(f.vertex3f), black_box(f.vertex3fv));
        let (normal3f, color3f) = (black_box(f.normal3f), black_box(f.color3f));
        let opens = |mode| {
            move || {
                (f.new_object)(2, capi::RT_COMPILE);
                (f.begin)(mode);
            }
        };
        let mut closes = || {
            (f.end)();
            (f.end_object)();
        };
        let at = |i: usize| (i as f32, (i % 7) as f32, (i % 11) as f32);
        let mut vertices = || {
            for i in 0..CALLS {
                let (x, y, z) = at(i);
                vertex3f(x, y, z);
            }
        };
        one(1, &mut opens(capi::RT_TRIANGLES), &mut vertices, &mut closes);
        let array: Vec<[f32; 3]> = (0..CALLS).map(|i| at(i).into()).collect();
        let mut from_array = || array.iter().for_each(|v| vertex3fv(v.as_ptr()));
        one(2, &mut opens(capi::RT_TRIANGLES), &mut from_array, &mut closes);
        one(3, &mut opens(capi::RT_TRIANGLE_STRIP), &mut vertices, &mut closes);
        for (row, attribute) in [(4, normal3f), (5, color3f)] {
            let mut both = || {
                for i in 0..CALLS {
                    let (x, y, z) = at(i);
                    attribute(z, x, 1.0);
                    vertex3f(x, y, z);
                }
            };
            one(row, &mut opens(capi::RT_TRIANGLES), &mut both, &mut closes);
        }
        (f.color3f)(1.0, 1.0, 1.0);
        let (begin, end) = (black_box(f.begin), black_box(f.end));
        let mut pairs = || {
            for _ in 0..CALLS {
                begin(capi::RT_QUADS);
                end();
            }
        };
        one(6, &mut nothing, &mut pairs, &mut || {});
        let (push, pop, translate) = (black_box(f.push), black_box(f.pop), black_box(f.translate));
        let mut matrices = || {
            for i in 0..CALLS {
                push();
                translate(i as f32, 1.0, 2.0);
                pop();
            }
        };
        one(7, &mut nothing, &mut matrices, &mut || {});
        let (instantiate, clear) = (black_box(f.instantiate), f.clear);
        one(8, &mut nothing, &mut || (0..CALLS).for_each(|_| instantiate(1)), &mut || clear());
        let mut placed = || {
            for i in 0..CALLS {
                push();
                translate(i as f32, 1.0, 2.0);
                instantiate(1);
                pop();
            }
        };
        one(9, &mut nothing, &mut placed, &mut || clear());
        let get_error = black_box(f.get_error);
        one(10, &mut nothing, &mut || (0..CALLS).for_each(|_| _ = black_box(get_error())), &mut || {});
        assert_eq!(get_error(), 0, "the calls are right");
        (f.exit)();
    }
    best
}

pub fn run(options: &Options) -> String {
    let rounds = if options.quick { QUICK_ROUNDS } else { ROUNDS };
    let linked = measure(&Functions::linked(), rounds);
    let shared = Functions::shared().map(|functions| measure(&functions, rounds));
    println!("{:50} {:>8} {:>8} {:>6}", "nanoseconds", "linked", "shared", "goal");
    let mut json = Vec::new();
    for (row, (name, goal)) in ROWS.iter().enumerate() {
        let text = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.1}"));
        let shared = shared.map(|all| all[row]);
        println!("{name:50} {:>8.1} {:>8} {:>6}", linked[row], text(shared), text(*goal));
        let number = |value: Option<f64>| value.map_or("null".to_owned(), |value| format!("{value:.2}"));
        json.push(format!(
            "{{\"call\": \"{name}\", \"linked\": {:.2}, \"shared\": {}, \"goal\": {}}}",
            linked[row],
            number(shared),
            number(*goal)
        ));
    }
    if shared.is_none() {
        println!("For the shared library: cargo build --release -p openrt -p openrt-c --lib");
    }
    format!("[\n{}\n]\n", json.join(",\n"))
}
