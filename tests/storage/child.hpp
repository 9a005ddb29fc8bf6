#pragma once

#include <csignal>
#include <cstdio>
#include <functional>
#include <stdexcept>
#include <string>
#include <sys/wait.h>
#include <unistd.h>
#include <utility>

#include "schemas/file_descriptor.hpp"
#include "tests/storage/store_fixture.hpp"

namespace divemesh::storage {

// A child process that waits for go() and then runs `work` with its own stores. Make it before this
// process opens the catalog: SQLite does not survive a fork.
class Child {
public:
    Child(const std::string& url, const std::function<void(Stores&)>& work) {
        int ends[2];
        if (pipe(ends) != 0) throw std::runtime_error("pipe");
        read_end_ = FileDescriptor(ends[0]);
        write_end_ = FileDescriptor(ends[1]);
        pid_ = fork();
        if (pid_ != 0) return;
        try {
            char word = 0;
            write_end_.close();
            if (read(read_end_.get(), &word, 1) != 1) _exit(2);
            Stores stores(url);
            work(stores);
            _exit(0);
        } catch (const std::exception& error) {
            fprintf(stderr, "child: %s\n", error.what());
            _exit(1);
        }
    }
    ~Child() {
        write_end_.close();  // a child that still waits for go() ends
        if (pid_ > 0) end();
    }
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;

    void go() { EXPECT_EQ(write(write_end_.get(), "g", 1), 1); }
    void kill_now() { kill(pid_, SIGKILL); }
    int end() {
        int status = 0;
        waitpid(std::exchange(pid_, -1), &status, 0);
        return status;
    }

private:
    FileDescriptor read_end_;  // of the pipe that go() writes to
    FileDescriptor write_end_;
    pid_t pid_ = -1;
};

}  // namespace divemesh::storage
