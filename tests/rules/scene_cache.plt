% Compiled scenes from inside Prolog: what saving and loading change, and what they do not.
:- use_module(library(plunit)).
:- use_module(library(lists)).
:- use_module(library(aggregate)).
:- use_module(facetlog_kb(scene)).
:- use_module(facetlog_kb(scene_cache)).

:- meta_predicate with_block(2).

with_block(Goal) :-
    gensym(test_scene, Scene),
    new_scene(Scene),
    forall(between(1, 50, I),
           ( add_fact(Scene, corner(f1, I, v1)),
             add_fact(Scene, area(f1, 0.5, 0.25)) )),
    tmp_file(scene, File),
    call_cleanup(call(Goal, Scene, File),
                 ( destroy_scene(Scene),
                   catch(delete_file(File), _, true) )).

empty(Scene) :-
    retractall(Scene:corner(_, _, _)),
    retractall(Scene:area(_, _, _)).

state(Files-Modules-Source) :-
    findall(F, source_file(F), Files0),
    sort(Files0, Files),
    aggregate_all(count, current_module(_), Modules),
    '$set_source_module'(Source, Source).

:- begin_tests(scene_cache).

test(facts_stay_and_come_back, Again == Facts) :-
    with_block(saved_and_loaded(Facts, Again)).
test(loaded_facts_are_dynamic_and_have_no_source) :-
    with_block([S, F]>>( save_scene(S, F, _),
                         empty(S),
                         load_saved_scene(S, F, 100),
                         predicate_property(S:corner(_, _, _), dynamic),
                         \+ predicate_property(S:corner(_, _, _), file(_)),
                         \+ ( clause(S:area(_, _, _), true, Clause),
                              clause_property(Clause, file(_)) ),
                         retract(S:corner(f1, 7, v1)) )).
test(neither_files_nor_modules_are_left, After == Before) :-
    state(Before),
    forall(between(1, 20, _),
           with_block([S, F]>>( save_scene(S, F, _),
                                empty(S),
                                load_saved_scene(S, F, 100) ))),
    state(After).
test(another_count_leaves_the_scene_empty) :-
    with_block([S, F]>>( save_scene(S, F, _),
                         empty(S),
                         \+ load_saved_scene(S, F, 99),
                         \+ S:corner(_, _, _) )).
test(derived_predicates_are_not_saved) :-
    with_block([S, F]>>( assertz(S:worked_out(1)),
                         save_scene(S, F, 100),
                         retract(S:worked_out(1)),
                         empty(S),
                         load_saved_scene(S, F, 100),
                         \+ catch(S:worked_out(_), _, fail) )).
test(no_folder, error(permission_error(write, file, _))) :-
    with_block([S, _]>>save_scene(S, '/nowhere/at/all', _)).
test(full_disk, [condition(access_file('/dev/full', write)),
                 error(io_error(write, _))]) :-
    with_block([S, _]>>save_scene(S, '/dev/full', _)).
test(no_file, error(existence_error(source_sink, _))) :-
    with_block([S, _]>>load_saved_scene(S, '/nowhere/at/all', 1)).
test(a_failed_save_changes_nothing, After == Before) :-
    state(Before),
    with_block([S, F]>>( catch(save_scene(S, '/nowhere/at/all', _), _, true),
                         save_scene(S, F, 100),
                         empty(S),
                         load_saved_scene(S, F, 100) )),
    state(After).
test(threads_save_at_once, Counts == [100, 100, 100, 100]) :-
    findall(Id, ( between(1, 4, _), thread_create(with_block(save_and_load_often), Id) ), Ids),
    findall(100, ( member(Id, Ids), thread_join(Id, true) ), Counts).

saved_and_loaded(Facts, Again, Scene, File) :-
    rows(Scene, Facts),
    save_scene(Scene, File, 100),
    empty(Scene),
    load_saved_scene(Scene, File, 100),
    rows(Scene, Again).

rows(Scene, Rows) :-
    findall(Row, ( ( Row = corner(_, _, _) ; Row = area(_, _, _) ), Scene:Row ), Rows).

save_and_load_often(Scene, File) :-
    forall(between(1, 20, _),
           ( save_scene(Scene, File, 100),
             empty(Scene),
             load_saved_scene(Scene, File, 100) )).

:- end_tests(scene_cache).
