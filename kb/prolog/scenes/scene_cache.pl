:- module(facetlog_scene_cache, [ cache_identity/1,     % -Identity
                                  save_scene/3,         % +Scene, +File, -Count
                                  load_saved_scene/3,   % +Scene, +File, +Count
                                  save_module/3,        % +Module, +Heads, +File
                                  load_saved_module/2   % +Module, +File
                                ]).

/** <module> Scenes as compiled files

A saved scene is a quick load file of SWI-Prolog: the clauses of one module as machine code, without
a source. Such a file is written from the clauses in memory and loaded about ten times as fast as
the same facts are read and asserted, and leaves no record of a source file behind.

There is no published way to do that: qcompile/2 wants a source file, is five times as slow as
asserting, and its result is tied to that source. So the predicates below it are used, which begin
with a dollar sign. Where another version of SWI-Prolog lacks one of them or they differ, the error
is met when a scene is saved, and then nothing is cached.

A file names the module that it was written from, and is loaded into the module that it names; the
caller (kb/loading/scene_cache.py) puts another name there. It must also have checked that the file is what
was written: SWI-Prolog ends the process on a damaged one.
*/

:- use_module(library(aggregate)).
:- use_module(library(lists)).
:- use_module(library(error)).
:- use_module(facetlog_kb(schema)).

%!  cache_identity(-Identity) is det.
%
%   Identity is a string that differs wherever compiled clauses might: version, build and machine.

cache_identity(Identity) :-
    findall(Flag=Value,
            ( member(Flag, [version, version_git, compiled_at, arch, address_bits]),
              current_prolog_flag(Flag, Value) ),
            Flags),
    format(string(Identity), "~q", [Flags]).

%!  save_scene(+Scene, +File, -Count) is det.
%
%   Writes the Count facts of Scene to File.
%
%   @error io_error or permission_error if File cannot be written.

save_scene(Scene, File, Count) :-
    must_be(atom, Scene),
    must_be(atom, File),
    findall(Head, scene_head(Scene, Head), Heads),
    save_module(Scene, Heads, File),
    fact_count(Scene, Count).

%!  save_module(+Module, +Heads, +File) is det.
%
%   Writes the clauses of these predicates of Module to File.
%
%   @error io_error or permission_error if File cannot be written.

save_module(Module, Heads, File) :-
    % SWI-Prolog writes one such file at a time.
    with_mutex(facetlog_scene_cache,
               setup_call_cleanup(
                   '$qlf_open'(File),
                   in_source_module(Module, write_clauses(Module, Heads)),
                   '$qlf_close')).

write_clauses(Module, Heads) :-
    '$qlf_start_module'(Module),
    forall(( member(Head, Heads),
             nth_clause(Module:Head, _, Clause) ),
           '$qlf_assert_clause'(Clause, development)),
    '$qlf_end_part'.

%!  load_saved_scene(+Scene, +File, +Count) is semidet.
%
%   Adds the facts of File, which names Scene, to that fresh scene. Fails, and leaves Scene empty,
%   if they are not Count.

load_saved_scene(Scene, File, Count) :-
    must_be(atom, Scene),
    must_be(atom, File),
    must_be(nonneg, Count),
    catch(( load_saved_module(Scene, File),
            fact_count(Scene, Found) ),
          Error, true),
    (   nonvar(Error)
    ->  forget_facts(Scene),
        throw(Error)
    ;   Found == Count
    ->  true
    ;   forget_facts(Scene),
        fail
    ).

%!  load_saved_module(+Module, +File) is det.
%
%   Adds the clauses of File, which names Module, to that module.

load_saved_module(Module, File) :-
    setup_call_cleanup(
        open(File, read, Stream, [type(binary)]),
        in_source_module(Module, '$qlf_load'(Module:Stream, _)),
        close(Stream)).

%   The source module is what clauses without a module belong to.
in_source_module(Module, Goal) :-
    setup_call_cleanup(
        '$set_source_module'(Before, Module),
        Goal,
        '$set_source_module'(Before)).

scene_head(Scene, Head) :-
    fact_schema(Name/Arity, _),
    functor(Head, Name, Arity),
    predicate_property(Scene:Head, dynamic).

fact_count(Scene, Count) :-
    aggregate_all(sum(N),
                  ( scene_head(Scene, Head),
                    predicate_property(Scene:Head, number_of_clauses(N)) ),
                  Count).

forget_facts(Scene) :-
    forall(scene_head(Scene, Head), retractall(Scene:Head)).
